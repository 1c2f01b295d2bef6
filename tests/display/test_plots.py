"""Plots draw what was given, on the axes that were given, and return them."""

import numpy as np
import pytest

from valvemodel import InputError, Record

PLOTS = [
    ("record", "plot"),
    ("record", "plot_loop"),
    ("run", "plot"),
    ("run", "plot_loop"),
    ("outcome", "plot_residuals"),
    ("diagnosis", "plot"),
    ("diagnosis", "plot_loop"),
    ("diagnosis", "plot_steps"),
    ("diagnosis", "plot_causes"),
]


@pytest.mark.parametrize(("name", "plot"), PLOTS)
def test_takes_axes_or_makes_them(name: str, plot: str, request):
    import matplotlib.pyplot as plt

    draw = getattr(request.getfixturevalue(name), plot)
    own = draw()
    assert own.has_data()
    assert own.get_xlabel().endswith("]")
    figure, given = plt.subplots()
    assert draw(given) is given
    assert plt.get_fignums() == [own.figure.number, figure.number], "given axes make no figure"
    own.figure.draw_without_rendering()


def test_curve_is_the_signal_in_the_unit_of_the_label(record):
    (curve,) = record.plot_loop(color="black").lines
    np.testing.assert_allclose(curve.get_xdata(), 1e3 * record.current)
    np.testing.assert_allclose(curve.get_ydata(), 1e3 * record.position)


def test_named_curves_have_a_legend(record, run):
    axes = run.plot(record.plot(label="measured"), label="simulated")
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["measured", "simulated"]


def test_stem_alone_is_drawn_over_its_force():
    force = np.linspace(0.0, 900.0, 50)
    record = Record.from_arrays("stem", time=np.arange(50) / 10.0, force=force, position=1e-4 * force)
    assert record.plot_loop().get_xlabel() == "force [N]"


def test_what_is_not_there_is_not_drawn(record, diagnosis):
    pairs = Record.from_arrays("pairs", current=record.current, position=record.position)
    with pytest.raises(InputError, match="needs the time"):
        pairs.plot()
    with pytest.raises(InputError, match="from 0 to 0"):
        diagnosis.plot(record=1)


def test_residuals_are_what_the_fit_leaves(outcome, record):
    (curve, _) = outcome.plot_residuals().lines
    assert len(curve.get_ydata()) == len(record)
    assert np.sqrt(np.mean(curve.get_ydata() ** 2)) == pytest.approx(1e3 * outcome.rms_fitted)
