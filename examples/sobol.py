"""Which uncertain parameter matters most for the natural frequency?

At rest it is √(18 θ/(1 + 2c)): a product of a function of the temperature and one of
the slenderness, so that its Sobol' indices are known exactly from four integrals. The
estimates from samples agree with them within their errors. The slenderness matters most
here.

Figure: Bars of the first-order and total Sobol' indices of temperature and slenderness,
about 0.19 and 0.81.

Source: A. Saltelli and others, Comput. Phys. Commun. 181 (2010) 259, for the
estimators.
"""

import numpy as np
import remanent as rm
from scipy.integrate import quad

ranges = {"temperature": (260.0, 340.0), "c": (0.6, 1.4)}
found = rm.uncertainty(
    rm.backbone,
    rm.Actuator(),
    [1.001],
    of=lambda result: result.frequency.isel({"initial.stretch": 0}, drop=True),
    parameter_ranges=ranges,
    sobol=True,
    samples=1024,
)


def relative_variance(factor, low, high):
    """Variance of a factor over its squared mean, for equally likely values."""
    mean = quad(factor, low, high)[0] / (high - low)
    square = quad(lambda p: factor(p) ** 2, low, high)[0] / (high - low)
    return square / mean**2 - 1


shares = np.array(
    [
        relative_variance(np.sqrt, *ranges["temperature"]),
        relative_variance(lambda c: (1 + 2 * c) ** -0.5, *ranges["c"]),
    ]
)
exact = shares / (np.prod(1 + shares) - 1)
print("first indices", found.first_index.values, "exact", exact)

with rm.plot.style.context():
    figure, axes = rm.plot.style.subplots(figsize=(4.6, 2.2))
    rm.plot.bars(found, ["first_index", "total_index"], ax=axes)
    figure.savefig("sobol.png")
