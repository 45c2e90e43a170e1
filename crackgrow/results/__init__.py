"""Results on disk: tables, frames, figures, summary and log; reads a run's results, never the solver."""
