"""Machines that integrate, under controllers that their users did not declare: recordings with concealed physics."""
