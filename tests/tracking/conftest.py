import pytest

from tests.support import films


@pytest.fixture(scope="session")
def clips(tmp_path_factory):
    """Lossless films of one disk on one path, and the path: bright on dark and dark on bright."""
    folder = tmp_path_factory.mktemp("clips")
    positions = films.path(60)
    films.encode(folder / "bright.avi", films.film(positions, seed=1))
    films.encode(folder / "dark.avi", films.film(positions, seed=2, background=215.0, marker=30.0))
    return folder, positions
