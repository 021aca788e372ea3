"""Price and gain of a second amplitude in the excitation."""
