"""Which of the effects found are to be named after all."""
