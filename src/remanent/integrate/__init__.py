"""From a Field to trajectories: methods, kernels, ensembles and their error estimates."""
