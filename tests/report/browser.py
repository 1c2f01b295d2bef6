"""Chromium without a window: what a page asks of the network, complains of, and takes up on a screen."""

from __future__ import annotations

import html
import json
import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path

import pytest

NAME = "chromium"
FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--hide-scrollbars"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync", "--enable-logging=stderr"),
)
UNREACHABLE = "--host-resolver-rules=MAP * ~NOTFOUND"

needs_chromium = pytest.mark.skipif(shutil.which(NAME) is None, reason="Chromium is not installed")


def visit(page: Path, *flags: str) -> subprocess.CompletedProcess[str]:
    """Open a file in a browser of its own, with the network out of reach, and wait until it is done."""
    own = (f"--user-data-dir={page.parent / 'profile'}", UNREACHABLE, *flags, page.as_uri())
    return subprocess.run([NAME, *FLAGS, *own], capture_output=True, text=True, timeout=120, check=True)


def complaints(done: subprocess.CompletedProcess[str]) -> list[str]:
    """Return what the page left on the console; a load that its policy forbids is among it."""
    return [line for line in done.stderr.splitlines() if "CONSOLE" in line]


def requests_of_page(log: Path) -> list[str]:
    """Return the addresses that a page from disk asked for, by the browser's own network log."""
    content = json.loads(log.read_text())
    asked = [event.get("params") or {} for event in content["events"]]
    return [each["url"] for each in asked if str(each.get("network_isolation_key", "")).startswith("file://")]


MEASURE = """
const channel = c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
const parsed = text => (text.match(/[\\d.]+/g) || []).map(Number);
const weights = [0.2126, 0.7152, 0.0722];
const luminance = rgb => weights.reduce((sum, weight, i) => sum + weight * channel(rgb[i] / 255), 0);
function background(element) {
  for (let each = element; each; each = each.parentElement) {
    const rgb = parsed(getComputedStyle(each).backgroundColor);
    if (rgb.length === 3 || rgb[3] > 0) return rgb;
  }
  return [255, 255, 255];
}
function contrasts(page) {
  const found = [];
  const walker = page.createTreeWalker(page.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const element = walker.currentNode.parentElement;
    if (!walker.currentNode.data.trim() || element.closest(".scrolls svg, style")) continue;
    const style = getComputedStyle(element);
    const colour = parsed(element.closest("svg") ? style.fill : style.color);
    const ends = [luminance(colour), luminance(background(element))].sort((a, b) => b - a);
    found.push([(ends[0] + 0.05) / (ends[1] + 0.05), walker.currentNode.data.trim()]);
  }
  return found.sort((a, b) => a[0] - b[0])[0];
}
function beyond(page) {
  const width = page.documentElement.clientWidth;
  return [...page.querySelectorAll("body *")].filter(each =>
    !each.closest(".scroll, .scrolls, svg *") && each.getBoundingClientRect().right > width + 0.5
  ).map(each => each.tagName + "." + each.className);
}
const results = {};
function measure(frame) {
  const page = frame.contentDocument;
  results[frame.name] = {
    width: page.documentElement.scrollWidth,
    beyond: beyond(page),
    scrolled: [...page.querySelectorAll(".scroll")].filter(each => each.scrollWidth > each.clientWidth + 1).length,
    answer: page.querySelector("section").getBoundingClientRect().bottom,
    contrast: contrasts(page),
    shown: [...page.querySelectorAll("[role=img]")].filter(each => each.getBoundingClientRect().height > 0).length,
    headings: [...page.querySelectorAll("h1, h2, h3, h4")].map(each => Number(each.tagName[1])),
  };
  document.getElementById("results").textContent = JSON.stringify(results);
}
"""


def measured(pages: Mapping[str, str], widths: tuple[int, ...], folder: Path) -> dict[str, dict]:
    """Lay pages out in frames of some widths, and return what a script finds there, by `NAME WIDTH`."""
    frames = "".join(
        f'<iframe name="{name} {width}" style="width: {width}px; height: 900px; border: 0" onload="measure(this)" '
        f'srcdoc="{html.escape(page)}"></iframe>'
        for name, page in pages.items()
        for width in widths
    )
    outer = folder / "frames.html"
    outer.write_text(f'<!DOCTYPE html><meta charset="utf-8"><script>{MEASURE}</script><pre id="results"></pre>{frames}')
    shown = visit(outer, "--dump-dom").stdout
    text = shown.partition('<pre id="results">')[2].partition("</pre>")[0]
    return json.loads(html.unescape(text))
