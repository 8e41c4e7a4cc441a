"""Can a large study be broken off and taken up again?

`sweep` computes a verb for every point of a grid and keeps what is done in a store. A
second call goes on where the first stopped; here it finds all done and computes
nothing. The values are bit for bit those of the verb itself.

Figure: Map of the amplitude over frequency and load: a bright tongue that leans to
lower frequencies as the load grows.

Source: the store is compared with one call of `frequency_response`.
"""

import numpy as np
import remanent as rm
import xarray as xr

body = rm.Actuator(temperature=350, dissipation=rm.Rayleigh(0.1))
drive = rm.SineSquared(b=0.4, omega=1.0)
omega = np.linspace(0.8, 1.6, 65)
over = {"b": np.linspace(0.1, 0.6, 26)}
options = {"omega": omega, "duration": 60.0, "discard": 40.0, "tolerance": 1e-6}
first = rm.sweep(body, drive, over, "frequency_response", store="swing.zarr", **options)
again = rm.sweep(body, drive, over, "frequency_response", store="swing.zarr", **options)
direct = rm.frequency_response(body, drive, over=over, **options)
print(
    "equal:", again.identical(first), np.array_equal(again.amplitude, direct.amplitude)
)
print("points in the store:", xr.open_zarr("swing.zarr").sizes)

with rm.plot.style.context():
    figure, axes = rm.plot.style.subplots(figsize=(4.8, 3.2))
    rm.plot.map(again, "amplitude", ax=axes)
    figure.savefig("study.png")
