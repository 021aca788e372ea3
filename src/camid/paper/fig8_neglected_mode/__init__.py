"""Fig. 8: errors due to a neglected mode."""
