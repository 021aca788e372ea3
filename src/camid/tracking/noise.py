"""Noise of the pixels, and what it does to the two centroids."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray

from camid.images.centroids import SOBEL_SUM
from camid.tracking.picture import Image

# J. Immerkær, Fast noise variance estimation, Computer Vision and Image Understanding 64 (1996): this filter answers
# to noise with 6 times its standard deviation and not at all to a ramp of grey levels.
LAPLACIAN = np.array([[1.0, -2.0, 1.0], [-2.0, 4.0, -2.0], [1.0, -2.0, 1.0]], np.float32)
GAIN = 6.0
# Median of the absolute value of a normal variable, in standard deviations.
NORMAL_MEDIAN = 0.674490
# Mean of it.
NORMAL_MEAN = sqrt(2.0 / pi)
# Whole grey levels are rounded.
ROUNDING = 1.0 / sqrt(12.0)
# Pixels from which the noise inside the marker is estimated.
FEWEST_INSIDE = 40
# A median has π/2 times the variance of a mean.
MEDIAN_VARIANCE = 0.5 * pi
# Standard deviations from the threshold beyond which it is certain whether a pixel counts.
FARTHEST = 6.0
# Standard deviation of a derivative by the 3 × 3 Sobel filter, in those of a pixel: √(1+4+1+1+4+1)/8.
SOBEL_NOISE = sqrt(12.0) / SOBEL_SUM


def pixel_noise(image: Image) -> float:
    """Standard deviation of the noise of the pixels in grey levels, at least that of rounding.

    The median of the filtered image's absolute values, so that edges do not count where they are few.
    """
    return noise_of(filtered(image))


def filtered(image: Image) -> NDArray[np.float32]:
    """Absolute answer of Immerkær's filter, without the pixels at the border."""
    import cv2

    answer = cv2.filter2D(image, cv2.CV_32F, LAPLACIAN)[1:-1, 1:-1]
    return np.abs(answer)


def noise_of(values: NDArray[np.float32]) -> float:
    """Standard deviation in grey levels from what `filtered` returns."""
    if not values.size:
        return ROUNDING
    middle = values.size // 2
    return max(ROUNDING, float(np.partition(values, middle, axis=None)[middle]) / (GAIN * NORMAL_MEDIAN))


def noise_inside(answer: NDArray[np.float32], mask: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], float | None]:
    """Inner pixels of the marker, and the noise there if they are enough for an estimate.

    Parameters
    ----------
    answer : ndarray, shape (height - 2, width - 2)
        From `filtered`.
    mask : ndarray of uint8, shape (height, width)
        1 where the marker is.
    """
    import cv2

    small = np.ones((3, 3), np.uint8)
    inner: NDArray[np.uint8] = cv2.erode(mask, small)  # type: ignore[assignment]
    # Farther inside, where the filter does not see the edge. There the mean can replace the median, which is nearly
    # zero where noise is clipped at white.
    values = answer[cv2.erode(inner, small)[1:-1, 1:-1] > 0]
    if values.size < FEWEST_INSIDE:
        return inner, None
    return inner, max(ROUNDING, float(np.mean(values)) / (GAIN * NORMAL_MEAN))


def grey_level_deviation(
    level: NDArray[np.float32],
    mask: NDArray[np.uint8],
    inner: NDArray[np.uint8],
    centre: tuple[float, float],
    threshold: float,
    noise: tuple[float, float],
    border: int,
) -> tuple[float, float]:
    """Standard deviation of the grey-level centroid in px.

    The centroid is x̂ = Σ x_i h_i / Σ h_i, where h_i = v_i if the level v_i above the background is larger than the
    threshold T, and 0 if not. Noise of h_i moves it by (x_i − x̂) δh_i / M with the mass M = Σ h_i, and an error b of
    the background by −b Σ (x_i − x̂) / M, the sum over the pixels above the threshold. With independent noise

        var x̂ = (Σ (x_i − x̂)² var h_i + (π/2) σ_0² / B (Σ (x_i − x̂))²) / M²,

    where the background is the median of B pixels with noise σ_0. Inside the marker var h_i = σ². At its edge the noise
    decides whether a pixel counts: with a = (T − v)/σ, φ and Q the normal density and upper tail,

        E h = v Q(a) + σ φ(a),  E h² = (v² + σ²) Q(a) + σ (v + T) φ(a),  var h = E h² − (E h)².

    Parameters
    ----------
    level : ndarray of float32, shape (height, width)
        v.
    mask, inner : ndarray of uint8, shape (height, width)
        1 where a pixel counts, and where it is an inner pixel of the marker.
    centre : (float, float)
        x̂, ŷ in px of ``level``.
    threshold : float
        T, grey levels.
    noise : (float, float)
        σ of the inner pixels, and σ_0; the larger one is that of the edge.
    border : int
        B.
    """
    import cv2
    from scipy.special import ndtr

    every, inside = cv2.moments(mask), cv2.moments(inner)
    rows, columns = np.nonzero(cv2.dilate(mask, np.ones((3, 3), np.uint8)) - inner)
    edge, sigma = level[rows, columns].astype(float), max(noise)
    a = (threshold - edge) / sigma
    density, tail = np.exp(-0.5 * a * a) / sqrt(2.0 * pi), ndtr(-a)
    mean = edge * tail + sigma * density
    variance = (edge * edge + sigma * sigma) * tail + sigma * (edge + threshold) * density - mean * mean
    mass = float(cv2.sumElems(cv2.multiply(level, mask, dtype=cv2.CV_32F))[0])
    deviations = []
    for place, c, first, second in ((columns, centre[0], "m10", "m20"), (rows, centre[1], "m01", "m02")):
        spread_inside = inside[second] - 2.0 * c * inside[first] + c * c * inside["m00"]
        at_edge = float(np.maximum(variance, 0.0) @ np.square(place - c))
        lever = every[first] - c * every["m00"]
        total = noise[0] ** 2 * spread_inside + at_edge + MEDIAN_VARIANCE * noise[1] ** 2 / border * lever**2
        deviations.append(sqrt(max(0.0, total)) / mass)
    return deviations[0], deviations[1]


def gradient_deviation(
    image: Image, relative_threshold: float, centre: tuple[float, float], noise: float
) -> tuple[float, float]:
    """Standard deviation of the gradient centroid in px.

    The centroid is the mean position of the N pixels whose gradient g_i is above the threshold T. A pixel is among them
    with probability p_i = Φ(z_i), z_i = (g_i − T)/σ_g, σ_g = σ √12/8. The part of its indicator that is linear in the
    noise, φ(z_i) δg_i/σ_g, is shared with its neighbours through the Sobel filter and is propagated to the pixels by
    the filter's transpose; the rest, of variance p_i (1 − p_i) − φ(z_i)², is taken as independent:

        var x̂ = (Σ_j σ² q_j² + Σ_i (x_i − x̂)² (p_i (1 − p_i) − φ(z_i)²)) / N²,
        q = S_xᵀ[(x_i − x̂) φ(z_i) cos θ_i / σ_g] + S_yᵀ[(x_i − x̂) φ(z_i) sin θ_i / σ_g],

    with the direction θ_i of the gradient. What whole pixels do to the position of a marker without noise is not in it.
    """
    import cv2
    from scipy.special import ndtr

    horizontal, vertical = (cv2.Sobel(image, cv2.CV_32F, *order, scale=1.0 / SOBEL_SUM) for order in ((1, 0), (0, 1)))
    gradient = cv2.magnitude(horizontal, vertical)
    sigma = SOBEL_NOISE * noise
    z = (gradient - relative_threshold * cv2.norm(gradient, cv2.NORM_INF)) / sigma
    selected = max(1, cv2.countNonZero((z > 0.0).view(np.uint8)))
    rows, columns = np.nonzero(np.abs(z) < FARTHEST)  # elsewhere no noise decides
    near = z[rows, columns].astype(float)
    density, probability = np.exp(-0.5 * near * near) / sqrt(2.0 * pi), ndtr(near)
    rest = np.maximum(probability * (1.0 - probability) - density * density, 0.0)
    cosine, sine = (part[rows, columns] / np.maximum(gradient[rows, columns], 1e-6) for part in (horizontal, vertical))
    deviations = []
    for place, c in ((columns, centre[0]), (rows, centre[1])):
        lever = place - c
        along_x, along_y = np.zeros((2, *z.shape), np.float32)
        along_x[rows, columns] = lever * density / sigma * cosine
        along_y[rows, columns] = lever * density / sigma * sine
        # The transpose of an antisymmetric filter is the filter with its sign changed.
        moved = cv2.Sobel(along_x, cv2.CV_32F, 1, 0) + cv2.Sobel(along_y, cv2.CV_32F, 0, 1)
        linear = (noise / SOBEL_SUM) ** 2 * float(np.sum(np.square(moved)))
        deviations.append(sqrt(linear + float(np.square(lever) @ rest)) / selected)
    return deviations[0], deviations[1]
