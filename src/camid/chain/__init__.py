"""The chain of the paper: hold, plant and sensor, sampled exactly; excitation, controller and the camera models."""
