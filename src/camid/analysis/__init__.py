"""What models say (responses, poles, steps) and how they follow a recording (fit, residual), with uncertainty."""
