"""Poles and zeros, and the ellipses about them."""

import control
import numpy as np
import pytest

import camid
from camid.analysis.poles_and_zeros import Root
from tests.support import linear_rig as rig


def test_roots_are_those_of_the_plant():
    system = control.tf([1.0, 5.0], [1.0, 3.0, 102.0, 100.0])
    table = camid.poles(system).numbers
    found = {k: (g["real"] + 1j * g["imaginary"]).to_numpy() for k, g in table.groupby("kind")}
    np.testing.assert_allclose(np.sort_complex(found["pole"]), np.sort_complex(system.poles()), rtol=1e-9)
    np.testing.assert_allclose(found["zero"], [-5.0])
    pair = table[table["imaginary"] > 0.0].iloc[0]
    assert pair["natural_frequency"] == pytest.approx(10.0)
    assert pair["damping_ratio"] == pytest.approx(0.1)
    assert table["variance_real"].isna().all()


def test_the_covariance_is_that_of_roots_drawn_from_the_estimate(identified):
    simulation = identified.simulation
    mean = np.array([*simulation.plant.numerator, *simulation.plant.denominator[1:]])
    drawn = np.random.default_rng(0).multivariate_normal(mean, simulation.covariance, 4000)
    lead = simulation.plant.denominator[0]
    roots = np.array([np.roots([lead, a1, a2]) for _, a1, a2 in drawn])
    upper = roots[roots.imag > 0.0]
    row = camid.poles(identified).numbers.query("imaginary > 0").iloc[0]
    expected = np.cov(upper.real, upper.imag)
    stated = np.array([[row["variance_real"], row["covariance"]], [row["covariance"], row["variance_imaginary"]]])
    np.testing.assert_allclose(stated, expected, atol=0.07 * np.trace(expected))
    assert row["natural_frequency_deviation"] == pytest.approx(np.std(np.abs(upper)), rel=0.07)
    assert row["damping_ratio_deviation"] == pytest.approx(np.std(-upper.real / np.abs(upper)), rel=0.07)
    # What identify prints of the same plant.
    printed = {r["name"]: r["standard_deviation"] for r in identified.characteristics()}
    assert row["natural_frequency_deviation"] == pytest.approx(printed["natural frequency"], rel=1e-4)
    assert row["damping_ratio_deviation"] == pytest.approx(printed["damping ratio"], rel=1e-4)


def test_an_ellipse_holds_95_per_cent():
    covariance = np.array([[0.04, 0.015], [0.015, 0.01]])
    root = Root("model", "pole", -1.0 + 5.0j, covariance)
    drawn = np.random.default_rng(1).multivariate_normal([-1.0, 5.0], covariance, 20000)
    edge = root.ellipse()
    from matplotlib.path import Path

    inside = Path(np.column_stack([edge.real, edge.imag])).contains_points(drawn)
    assert np.mean(inside) == pytest.approx(0.95, abs=0.006)


def test_a_real_pole_has_an_interval(identified):
    table = rig.recording(count=600)
    found = camid.identify(table, rig.simulation(plant=rig.plant([10.0], [1.0, 10.0])))
    (root,) = camid.poles(found).roots
    assert np.all(root.ellipse().imag == 0.0)
    assert np.max(root.ellipse().real) - root.value.real == pytest.approx(1.959964 * np.sqrt(root.covariance[0, 0]))


def test_a_repeated_pole_has_no_deviation_and_that_is_said():
    covariance = [[0.01, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0, 0.0, 0.01]]
    plant = rig.plant([100.0], [1.0, 20.0, 100.0], covariance=covariance)
    plant["standard_deviations"] = {"numerator": [0.1], "denominator": [0.0, 0.1, 0.1]}
    view = camid.poles(rig.simulation(plant=plant))
    assert all(root.covariance is None for root in view.roots)
    assert any("repeated root" in sentence for sentence in view.said())
    assert view.figure() is not None


def test_zeros_have_ellipses_too():
    plant = rig.plant([20.0, 100.0], [1.0, 2.0, 100.0], covariance=np.diag([0.04, 1.0, 0.0, 0.0]).tolist())
    plant["standard_deviations"] = {"numerator": [0.2, 1.0], "denominator": [0.0, 0.0, 0.0]}
    roots = {r.kind: r for r in camid.poles(rig.simulation(plant=plant)).roots if r.value.imag >= 0.0}
    # z = −b1/b0: var z = var b1/b0² + b1² var b0/b0⁴
    assert roots["zero"].covariance[0, 0] == pytest.approx(1.0 / 400.0 + 1e4 * 0.04 / 160000.0, rel=1e-4)
    assert np.all(roots["pole"].covariance == 0.0)
