"""Fig. 5: block diagram of the second version of Model #1."""

from camid.paper.block_diagrams import draw_second_version as draw

__all__ = ["draw"]
