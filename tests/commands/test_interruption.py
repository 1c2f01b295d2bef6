"""Ctrl-C reaches a command wherever it is, and the process ends with the status that the command gives."""

import subprocess
import sys
import textwrap

import pytest

IN_TEXT = """
exec("signal.raise_signal(signal.SIGINT)")
"""

IN_FINALISER = """
class Held:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)
held = Held()
del held
time.sleep(30.0)
"""

BELOW_A_LIBRARY_THAT_CALLS_BACK = """
import ctypes
def back():
    signal.raise_signal(signal.SIGINT)
called = ctypes.CFUNCTYPE(None)(type(back)(back.__code__, {"signal": signal, "__name__": "llvmlite.binding.ffi"}))
called()
time.sleep(30.0)
"""


@pytest.mark.parametrize(
    "place", [IN_TEXT, IN_FINALISER, BELOW_A_LIBRARY_THAT_CALLS_BACK], ids=["text", "finaliser", "called back"]
)
def test_an_interruption_is_neither_lost_nor_the_end_of_the_interpreter(place, tmp_path):
    program = (
        "import signal, sys, time\nfrom valvemodel.commands.interruption import listen\nlisten()\ntry:\n"
        + textwrap.indent(place, "    ")
        + "except KeyboardInterrupt:\n    sys.exit(130)\n"
    )
    (tmp_path / "interrupted.py").write_text(program)
    words = [sys.executable, "-m", "interrupted"]
    ended = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=25, check=False)
    assert ended.stderr == ""
    assert ended.returncode == 130
