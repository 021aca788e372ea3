"""What every job of the workflow uses: inputs and logs, reproducible arithmetic, datasets and tolerances."""
