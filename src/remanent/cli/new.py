"""``remanent new``: a commented study file to start from."""

from __future__ import annotations

from pathlib import Path

import click

from remanent._errors import InputError

#: The file: a chart of regimes, small enough to be computed in seconds.
TEMPLATE = """\
# A study: one verb, for every combination of the values in [over].
# Run it with `remanent run`; what was computed is kept, and a run that was broken off goes on.

# What is computed: any verb of the package that takes `over`, here the classification of the
# motion as periodic, quasi-periodic or chaotic.
verb = "classify"

# The folder for the results, beside this file. `xarray.open_zarr` opens it.
store = "{name}.zarr"

# Seconds of a clock after which a single point is given up; leave it out for no cap.
# point_seconds = 60

# The actuator, in dimensionless numbers; what is left out has its usual value. For one's own
# equations write [system] with kind = "LagrangianSystem" or "FirstOrderSystem" instead.
[actuator]
temperature = 350    # K
prestress = 0.0      # nominal stress of the dead loads over the shear modulus
c = 1.0              # slenderness, H^2/L^2
# Parts of the model are tables with the kind of the part.
material = {{ kind = "NeoHookean" }}    # or {{ kind = "Gent", jm = 50 }}
dissipation = [{{ kind = "Rayleigh", eta = 0.05 }}]

# Sizes in SI. With them, loads, frequencies and times may have units, as in b = "140 mT" and
# in omega = "50 Hz". The slenderness c above then follows from the sizes and is left out.
# [actuator.si]
# shear_modulus = "100 kPa"
# density = "2000 kg/m^3"
# half_length = "5 mm"
# half_thickness = "0.5 mm"
# remanence = "143 mT"

# The magnetic load as a function of time: m = (b sin(omega tau))^2. Other kinds are Constant,
# Sine, Sines, Steps, Ramp, Chirp and Sampled.
[drive]
kind = "SineSquared"
b = 0.4
omega = 1.25

# Fields of the actuator and the drive that take many values, each a dimension of the result.
[over]
b = {{ from = 0.2, to = 1.0, count = 5 }}    # as numpy.linspace
omega = {{ from = 0.8, to = 2.0, count = 6, spacing = "log" }}    # neighbours in one ratio
# Fields of parts have dots in their names, and stand in quotes:
# "dissipation.0.eta" = [0.01, 0.05, 0.1]
# Fields that go together, one value with one, have the same `dim`:
# temperature = {{ values = [300, 350], dim = "case" }}
# prestress = {{ values = [0.0, 0.2], dim = "case" }}
# Quasi-random points in a box, in place of a grid; the count is a power of 2:
# [over.sobol]
# count = 64
# ranges = {{ b = [0.2, 1.0], omega = [0.8, 2.0] }}

# Arguments of the verb.
[options]
periods = 200        # periods of the drive that are looked at
tolerance = 1e-8     # of the error that each period adds
"""


@click.command()
@click.argument("name", default="study")
def new(name: str) -> None:
    """Write a commented study file to start from, NAME.toml."""
    path = Path(name if name.endswith(".toml") else f"{name}.toml")
    if not path.stem.isprintable() or set('"\\') & set(path.stem):
        raise InputError(
            "NAME",
            must="be a name without quotes and backslashes",
            got=repr(name),
            why="The file names its store after it.",
            fix="Write for example `remanent new chart`.",
        )
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(TEMPLATE.format(name=path.stem))
    except FileExistsError:
        raise InputError(
            "NAME",
            must="be a name that is free",
            got=str(path),
            why="The file is there already, and nothing is written over.",
            fix="Pass another name, or remove the file.",
        ) from None
    click.echo(f"{path}: edit it, then run it with `remanent run {path}`")
