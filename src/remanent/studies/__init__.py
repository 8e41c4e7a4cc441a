"""The verbs: each joins a model and the integrator and returns a labelled dataset."""
