"""Linkage: what the stem drags along through a play, or through two side by side where the joint is worn."""

from __future__ import annotations

from valvemodel.compiled import compiled, inlined

TOUCHING = 1e-12
"""Play within this of being taken up is taken up. [m]"""


@inlined
def dragged(linkage, position, half_width):
    """Return where a play of a half width leaves what the stem drags along. [m]"""
    return min(max(linkage, position - half_width), position + half_width)


@inlined
def half_widths(p):
    """Return half the play of the tight and of the loose part of a worn joint. [m]"""
    return p.backlash_half_width * (1.0 - p.backlash_wear), p.backlash_half_width * (1.0 + p.backlash_wear)


@inlined
def drag_linkage(p, state):
    """Take the linkage along with a stem that has moved one way."""
    if p.backlash_wear > 0.0:
        drag_both(p, state, state.position)
    elif p.backlash_half_width == 0.0:
        state.linkage = state.position
    else:
        state.linkage = dragged(state.linkage, state.position, p.backlash_half_width)


@inlined
def drag_both(p, state, position):
    """Take both parts of a worn joint along; the linkage goes half the way of each."""
    tight, loose = half_widths(p)
    state.tight_linkage = dragged(state.tight_linkage, position, tight)
    state.loose_linkage = dragged(state.loose_linkage, position, loose)
    state.linkage = 0.5 * (state.tight_linkage + state.loose_linkage)


@inlined
def part_dragged(p, linkage_way, stem_way):
    """Return which part of the stem's way the linkage goes in a step that ends where a play closes: 0, 1/2 or 1.

    What it moves where its play closes at the end is rounding.
    """
    if p.backlash_wear > 0.0:
        return 0.5 * ((4.0 * linkage_way > stem_way) + (4.0 * linkage_way > 3.0 * stem_way))
    return 1.0 if 2.0 * linkage_way > stem_way else 0.0


@inlined
def dragged_place(p, state, side, part, position):
    """Return where the linkage is as the stem drags a part of it through a position: only the loose one rests. [m]"""
    place = position - side * p.backlash_half_width
    if part == 1.0:
        return place
    return 0.5 * (place + state.loose_linkage + side * p.backlash_half_width * p.backlash_wear)


@compiled
def way_to_contact(p, state, side):
    """Return how far the stem still goes before its play is taken up, or the next of two. [m]"""
    if p.backlash_wear == 0.0:
        return side * (state.linkage - state.position) + p.backlash_half_width
    tight, loose = half_widths(p)
    contact = side * (state.tight_linkage - state.position) + tight
    return contact if contact > TOUCHING else side * (state.loose_linkage - state.position) + loose


@compiled
def rest_linkage(p, state, position):
    """Put the linkage at rest at a position; the stem starts `backlash_start` half plays below it."""
    half_spread = p.backlash_start * p.backlash_half_width * p.backlash_wear
    state.linkage = position
    state.tight_linkage, state.loose_linkage = position - half_spread, position + half_spread


@compiled
def shift_linkage(state, shift):
    """Shift the linkage as it is."""
    state.linkage += shift
    state.tight_linkage += shift
    state.loose_linkage += shift
