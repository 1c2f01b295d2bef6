# %% [markdown]
# # First steps: from a record to a cause
#
# Run it from the repository's root, `python notebooks/first_steps.py`, or cell by cell in an editor that
# knows `# %%`. It goes through the public doors only.

# %%
from pathlib import Path

import numpy as np

from diagnosis.diagnose import diagnose
from identification.outcome import fit_records
from valvemodel import Model, Record, read_record, read_valve, simulate

# %% [markdown]
# ## A record
#
# Units are read from the header; inside, everything is SI. The first 30 s will do here.

# %%
path = Path("diagnosis/examples/demo.csv")
whole = read_record(path)
kept = whole.time < 30.0
record = Record.from_arrays(
    whole.name, time=whole.time[kept], current=whole.current[kept], position=whole.position[kept]
)
print(f"{record.name}: {len(record)} rows, one every {1e3 * record.interval:.0f} ms")

# %% [markdown]
# ## The valve as given
#
# The simulation is exact: it sticks and slips by mode, without a step size.

# %%
valve = read_valve("calibrated")
model = Model(valve.name, valve.values)
start = float(np.median(record.position[:5]))
run = simulate(model, time=record.time, current=record.current, start_position=start)


def gap(position: np.ndarray) -> float:
    """Root mean square of measured less simulated position. [m]"""
    return float(np.sqrt(np.mean((record.position - position) ** 2)))


print(f"as given: {1e3 * gap(run.position):.1f} mm rms; modes {sorted(set(run.mode_names))}")

# %% [markdown]
# ## The same valve with its numbers fitted
#
# `std` is None where the record does not determine a number.

# %%
outcome = fit_records([record], model)
for each in outcome.parameters:
    print(f"{each.name:18s} {each.value:10.4g} {each.unit:8s} std {each.std}")
print(f"fitted: {1e3 * outcome.rms_fitted:.2f} mm, unseen: {1e3 * outcome.rms_unseen:.2f} mm")

# %% [markdown]
# ## What is missing
#
# Every effect of the library is tried, alone and with others, and scored on blocks of time that were not
# fitted.

# %%
answer = diagnose([record], model, jobs=1).as_json()
best, size = answer["causes"][0], answer["gap"]
print(f"verdict {answer['verdict']}; best {' + '.join(best['effects']) or 'none'}, {best['probability']:.2f}")
for name in ("as_given", "refitted", "with_cause", "noise_floor"):
    print(f"{name:12s} {1e3 * size[name]:6.2f} mm")
