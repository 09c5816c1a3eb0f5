import numpy as np
import pytest

import squeakscope as s


@pytest.mark.parametrize("method", ["dop853", "tsit5", "rodas5p", "auto"])
def test_an_oscillator_reaches_its_closed_form(method) -> None:
    t = np.linspace(0.0, 10.0, 101)
    found = s.integrate(lambda t, z: np.array([z[1], -z[0]]), [1.0, 0.0], t, method=method, tolerance=1e-9)
    assert np.max(np.abs(found.z[:, 0] - np.cos(t))) < 1e-6
    assert found.stats.steps > 0 and len(found.event_t) == 0


def test_a_bouncing_ball_jumps_at_its_events() -> None:
    def reset(t, z, guard):
        return [0.0, -0.5 * z[1]]

    # The impacts accumulate at 1.354 s.
    t = np.linspace(0.0, 1.3, 27)
    found = s.integrate(
        lambda t, z, signs: [z[1], -9.81], [1.0, 0.0], t, events=lambda t, z: [z[0]], reset=reset
    )
    fall = np.sqrt(2 / 9.81)
    assert found.event_t[:2] == pytest.approx([fall, 2 * fall], abs=1e-8)
    assert found.event_z[0] == pytest.approx([0.0, 0.5 * 9.81 * fall], abs=1e-7)
    assert found.z[:, 0].min() > -1e-9
    assert np.all(found.event_index == 0)


def test_a_law_changes_with_the_sign_of_its_guard() -> None:
    # Dry friction: each half swing loses twice the offset of the equilibrium.
    def rhs(t, z, signs):
        return [z[1], -z[0] - 0.1 * signs[0]]

    t = [0.0, np.pi, 2 * np.pi, 3 * np.pi]
    found = s.integrate(rhs, [-1.0, 1e-12], t, events=lambda t, z: [z[1]])
    assert found.z[:, 0] == pytest.approx([-1.0, 0.8, -0.6, 0.4], abs=1e-6)
    assert found.event_t[:2] == pytest.approx([np.pi, 2 * np.pi], abs=1e-6)


def test_exponents_of_the_lorenz_system() -> None:
    def rhs(t, z):
        x, y, w = z
        return 10 * (y - x), x * (28 - w) - y, x * y - 8 / 3 * w

    def jacobian(t, z):
        x, y, w = z
        return [[-10, 10, 0], [28 - w, -1, -x], [y, x, -8 / 3]]

    options = {"settle": 10.0, "interval": 0.1, "method": "tsit5", "tolerance": 1e-6, "max_step": 0.1}
    found = s.exponents(rhs, [1.0, 1.0, 20.0], 60.0, jacobian=jacobian, **options)
    values = [e.value for e in found.exponents_per_s]
    # Their sum is the divergence of the flow.
    assert sum(values) == pytest.approx(-41 / 3, rel=1e-3)
    assert values[0] == pytest.approx(0.906, abs=0.2)
    by_differences = s.exponents(rhs, [1.0, 1.0, 20.0], 60.0, **options)
    assert sum(e.value for e in by_differences.exponents_per_s) == pytest.approx(-41 / 3, rel=1e-3)


def test_exceptions_of_functions_come_back() -> None:
    def rhs(t, z):
        if t > 0.5:
            raise ZeroDivisionError("at 0.5")
        return [-z[0]]

    with pytest.raises(ZeroDivisionError, match="at 0.5"):
        s.integrate(rhs, [1.0], [0.0, 1.0])
    with pytest.raises(s.InputError, match="returned 2 numbers; it must return 1"):
        s.integrate(lambda t, z: [1, 2], [1.0], [0.0, 1.0])
    with pytest.raises(s.InputError, match="ascending"):
        s.integrate(rhs, [1.0], [1.0, 0.0])
    with pytest.raises(s.Error, match="not finite"):
        s.integrate(lambda t, z: [np.inf], [1.0], [0.0, 1.0])
