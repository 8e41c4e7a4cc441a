"""Labelled results: the first layer that knows xarray."""
