import numpy as np
import pytest

import squeakscope as s


@pytest.mark.parametrize("method", ["dop853", "tsit5", "rodas5p", "auto"])
def test_an_oscillator_reaches_its_closed_form(method) -> None:
    t = np.linspace(0.0, 10.0, 101)
    found = s.integrate(lambda t, z: np.array([z[1], -z[0]]), [1.0, 0.0], t, method=method, tolerance=1e-9)
    assert np.max(np.abs(found.z[:, 0] - np.cos(t))) < 1e-6
    assert found.stats.steps > 0 and len(found.event_t) == 0


def test_a_bouncing_ball_jumps_at_its_events_and_comes_to_rest() -> None:
    # The impacts accumulate at 1.354 s. There the third state switches to rest.
    def reset(t, z, guard):
        return [0.0, -0.5 * z[1], 0.0] if z[1] < -1e-6 else [0.0, 0.0, 1.0]

    def rhs(t, z, signs):
        return [z[1], 0.0 if z[2] else -9.81, 0.0]

    t = np.linspace(0.0, 2.0, 41)
    found = s.integrate(rhs, [1.0, 0.0, 0.0], t, events=lambda t, z: [1.0 if z[2] else z[0]], reset=reset)
    fall = np.sqrt(2 / 9.81)
    assert found.event_t[:2] == pytest.approx([fall, 2 * fall], abs=1e-8)
    assert found.event_z[0] == pytest.approx([0.0, 0.5 * 9.81 * fall, 0.0], abs=1e-7)
    assert found.event_t[-1] == pytest.approx(3 * fall, abs=1e-5)
    assert found.z[:, 0].min() > -1e-9 and np.all(found.z[-1] == [0.0, 0.0, 1.0])
    assert np.all(found.event_index == 0)


@pytest.mark.parametrize("has_phase", [False, True])
def test_exponents_of_a_ball_on_a_shaken_table(has_phase) -> None:
    """Each impact contracts by the square of the restitution, whether time is explicit or a state."""
    amplitude, restitution = 2.5, 0.8

    def table(t, z):
        return (z[3], z[2]) if has_phase else (np.sin(t), np.cos(t))

    def reset(t, z, guard):
        sin, cos = table(t, z)
        after = [amplitude * sin, -restitution * z[1] + (1 + restitution) * amplitude * cos]
        return [*after, z[2], z[3]] if has_phase else after

    def rhs(t, z, signs):
        return [z[1], -1.0, -z[3], z[2]] if has_phase else [z[1], -1.0]

    def events(t, z):
        return [z[0] - amplitude * table(t, z)[0]]

    start = [6.0, 0.0, 1.0, 0.0] if has_phase else [6.0, 0.0]
    options = {"max_step": 0.5, "events": events, "reset": reset}
    found = s.exponents(rhs, start, 600.0, settle=50.0, interval=0.3, **options)
    before = s.integrate(rhs, start, [0.0, found.settle], **options)
    count = found.crossings - len(before.event_t)
    assert found.exponents.sum() == pytest.approx(2 * np.log(restitution) * count / found.averaged, rel=1e-6)
    assert found.attractor == "chaos" and found.exponents[0] > 0.04
    assert found.motion == ("free" if has_phase else "driven")


def test_time_dependence_is_found_and_not_denied() -> None:
    period = 2 * np.pi / 1.2

    def duffing(t, z):
        return [z[1], -0.3 * z[1] + z[0] - z[0] ** 3 + 0.2 * np.cos(1.2 * t)]

    options = {"settle": 30 * period, "interval": period / 20}
    found = s.exponents(duffing, [1.0, 0.0], 100 * period, **options)
    assert found.attractor == "phase-locked" and found.description == "phase-locked to the drive: all exponents are negative"
    with pytest.raises(s.InputError, match="autonomous: a function changes with time"):
        s.exponents(duffing, [1.0, 0.0], 100 * period, autonomous=True, **options)
    # An implicit method has its order only with the derivative by time.
    t = np.linspace(0, 20, 5)
    exact = s.integrate(duffing, [1.0, 0.0], t, tolerance=1e-12).z
    implicit = s.integrate(duffing, [1.0, 0.0], t, method="rodas5p", tolerance=1e-8)
    assert np.abs(implicit.z - exact).max() < 1e-5 and implicit.stats.steps < 1000


def test_a_fixed_step_is_given() -> None:
    t = np.linspace(0, 10, 101)
    with pytest.raises(s.InputError, match="max_step: give the step of rk4"):
        s.integrate(lambda t, z: [z[1], -z[0]], [1.0, 0.0], t, method="rk4")
    found = s.integrate(lambda t, z: [z[1], -z[0]], [1.0, 0.0], t, method="rk4", max_step=0.01)
    assert found.z[:, 0] == pytest.approx(np.cos(t), abs=1e-7)


def test_dry_friction_sticks_and_slips() -> None:
    # A mass on a belt sticks until the spring reaches the friction force, and is then at rest on the moving belt's limit.
    mu, belt = 0.5, 0.1

    def rhs(t, z, signs):
        return [z[1], -z[0] - mu * signs[0]]

    found = s.integrate(rhs, [0.0, belt], np.linspace(0, 8, 161), events=lambda t, z: [z[1] - belt])
    sticks = found.t < mu / belt - 1e-9
    assert np.abs(found.z[sticks, 1] - belt).max() < 1e-12
    assert found.z[sticks, 0] == pytest.approx(belt * found.t[sticks], abs=1e-9)
    assert found.event_t[0] == pytest.approx(mu / belt, abs=1e-7)
    # It slips: free vibration about mu with the amplitude of the belt speed.
    after = found.t > mu / belt
    assert found.z[after, 0] == pytest.approx(mu + belt * np.sin(found.t[after] - mu / belt), abs=1e-6)


def test_driven_dry_friction_and_its_exponents() -> None:
    def rhs(t, z, signs):
        return [z[1], -z[0] - 0.3 * signs[0] + 2 * np.cos(0.5 * t)]

    def events(t, z):
        return [z[1]]

    # The friction of a steep smooth law has the same motion.
    t = np.linspace(0, 60, 601)
    sharp = s.integrate(rhs, [0.0, 0.0], t, events=events)
    smooth = s.integrate(
        lambda t, z: [z[1], -z[0] - 0.3 * np.tanh(1e4 * z[1]) + 2 * np.cos(0.5 * t)], [0.0, 0.0], t,
        method="rodas5p", max_step=0.05,
    )
    assert np.abs(sharp.z - smooth.z).max() < 2e-3
    weak = s.integrate(lambda t, z, signs: [z[1], -z[0] - 3 * signs[0] + 2 * np.cos(0.5 * t)], [0.0, 0.0], t, events=events)
    assert np.all(weak.z == 0.0)
    # Sticking forgets the velocity, and the damping of the slips contracts the rest.
    damped = s.exponents(lambda t, z, signs: [z[1], -z[0] - 0.1 * z[1] - 0.6 * signs[0] + 2 * np.cos(0.5 * t)], [0.0, 0.0],
                         200.0, settle=60.0, interval=0.1, events=events)
    assert damped.attractor == "phase-locked" and damped.exponents[0] < 0 and damped.exponents[1] == -np.inf


def test_two_contacts_stick_at_once() -> None:
    # Two masses, each with its friction, between springs: both come to rest within their friction.
    def rhs(t, z, signs):
        x, y, u, v = z
        return [u, v, -2 * x + y - 0.2 * signs[0], x - 2 * y - 0.3 * signs[1]]

    found = s.integrate(rhs, [1.0, -0.5, 0.0, 0.0], np.linspace(0, 40, 401), events=lambda t, z: [z[2], z[3]])
    x, y, u, v = found.z[-1]
    assert abs(u) < 1e-12 and abs(v) < 1e-12
    assert abs(-2 * x + y) < 0.2 and abs(x - 2 * y) < 0.3
    assert np.abs(np.diff(found.z[-20:], axis=0)).max() < 1e-12


def test_events_end_an_integration_and_have_a_direction() -> None:
    def run(**options):
        return s.integrate(lambda t, z, signs: [z[1], -z[0]], [1.0, 0.0], np.linspace(0, 20, 201),
                           events=lambda t, z: [z[0], z[1]], **options)

    falling = run(direction=-1)
    assert falling.event_t[falling.event_index == 0][:2] == pytest.approx([np.pi / 2, 2.5 * np.pi], abs=1e-7)
    each = run(direction=[1, -1])
    assert each.event_t[each.event_index == 0][0] == pytest.approx(1.5 * np.pi, abs=1e-7)
    ended = run(terminal=[True, False], direction=[1, 0])
    assert ended.event_t[-1] == pytest.approx(1.5 * np.pi, abs=1e-7)
    assert ended.t[-1] < ended.event_t[-1] and len(ended.z) == len(ended.t) == 48
    with pytest.raises(s.InputError, match="terminal: give one value, or 2"):
        run(terminal=[True])


def test_an_error_keeps_what_was_computed() -> None:
    def zeno(**options):
        s.integrate(lambda t, z, signs: [z[1], -9.81], [1.0, 0.0], np.linspace(0, 2, 41), events=lambda t, z: [z[0]],
                    reset=lambda t, z, guard: [0.0, -0.5 * z[1]], **options)

    with pytest.raises(s.Error, match="let `reset` switch a state to rest") as caught:
        zeno(max_crossings=200)
    kept = caught.value.result
    assert kept.t[-1] == pytest.approx(1.35) and len(kept.z) == 28 and len(kept.event_t) > 200
    # Fewer crossings are an error earlier.
    with pytest.raises(s.Error) as caught:
        zeno(max_crossings=60)
    assert len(caught.value.result.event_t) < len(kept.event_t)


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
    values = found.exponents
    assert found.kaplan_yorke.value == pytest.approx(2.06, abs=0.02) and found.signs[0] == "positive"
    assert np.all(values.half_width > 0)
    # Their sum is the divergence of the flow.
    assert sum(values) == pytest.approx(-41 / 3, rel=1e-3)
    assert values[0] == pytest.approx(0.906, abs=0.2)
    by_differences = s.exponents(rhs, [1.0, 1.0, 20.0], 60.0, **options)
    assert by_differences.exponents.sum() == pytest.approx(-41 / 3, rel=1e-3)


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
    with pytest.raises(s.InputError, match="reset: give `events`"):
        s.integrate(rhs, [1.0], [0.0, 0.4], reset=lambda t, z, guard: z)
    with pytest.raises(s.InputError, match="events: give one function"):
        s.integrate(lambda t, z, signs: -z, [1.0], [0.0, 0.4], events=[lambda t, z: z])
    with pytest.raises(s.InputError, match="rhs: complex numbers"):
        s.integrate(lambda t, z: 1j * z, [1.0], [0.0, 0.4])
