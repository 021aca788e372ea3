"""Constants beside a plant that every kind may have, and that a simulation may leave open."""

from __future__ import annotations

from camid.effects.parameter import Parameter

# Constants that every kind may have, measured by what they are added to.
OFFSET = Parameter("offset", "y", "reading at the plant's zero", scale="output")
BIAS = Parameter("bias", "u", "what is added to the input", scale="input")
SKEW = Parameter("skew", "", "relative rate of the camera's clock", -0.1, 0.1, scale="slip")
# Latency, in periods, that is none.
AT_ZERO = 1e-6
LATENCY = Parameter("latency", "s", "from the end of an exposure to its time stamp", 0.0, scale="period")
