"""Pictures of the results of :mod:`camid.analysis`, in the look of :mod:`camid.plotting`."""
