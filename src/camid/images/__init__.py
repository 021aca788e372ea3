"""Images of a moving marker and its position in them (paper section 2.1)."""
