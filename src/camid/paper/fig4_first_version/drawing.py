"""Fig. 4: block diagram of the first version of Model #1."""

from camid.paper.block_diagrams import draw_first_version as draw

__all__ = ["draw"]
