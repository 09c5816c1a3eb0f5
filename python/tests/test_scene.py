import pickle

import pytest

import squeakscope as s


def test_keys_of_a_scene_are_replaced_by_path_or_name() -> None:
    scene = s.Scene.load("tilt-ramp")
    changed = scene.replace(**{"load.tilt_deg": 4, "contact.stiffness_distribution": "pre-stress"}, nodes=28)
    assert changed["load.tilt_deg"] == 4.0
    assert changed["nodes"] == 28
    assert scene["load.tilt_deg"] == 0.0
    assert changed != scene
    assert s.Scene.parse(changed.text, changed.name) == changed
    assert changed.replace(nodes=None)["nodes"] != 28
    ramp = changed.replace(**{"load.tilt": [{"time_ms": 0, "tilt_deg": 1}, {"time_ms": 10, "tilt_deg": 2.5}]})
    assert ramp["load.tilt_deg"] == 1.0


def test_scenes_are_values() -> None:
    scene = s.Scene.load("doubled-torus-3deg")
    assert pickle.loads(pickle.dumps(scene)) == scene
    assert "doubled-torus-3deg" in repr(scene) and scene.name in s.scenes()
    assert scene.duration > 0 and scene.sample_rate == 200_000
    assert scene.parameters["load.tilt_deg"] == 3.0


@pytest.mark.parametrize(
    ("change", "part"),
    [
        (lambda: s.Scene.load("torus-1.75dge"), "did you mean `torus-1.75deg`"),
        (lambda: s.Scene.load("doubled-torus-3deg").replace(ndoes=3), "unknown key `ndoes`"),
        (lambda: s.Scene.load("doubled-torus-3deg").replace(nodes=0), "out of range"),
        (lambda: s.Scene.load("doubled-torus-3deg").replace(**{"load.tilt": 3}), "a constant is `load.tilt_deg`"),
        (lambda: s.sweep("doubled-torus-3deg", {"load.tilt": [3]}), "did you mean `load.tilt_deg`"),
        (lambda: s.run("doubled-torus-3deg", duration=-1.0), "time.duration_ms"),
        (lambda: s.stability("mass-on-belt"), "a ball joint is required"),
        (lambda: s.run("doubled-torus-3deg", record="x.csv"), "does not end in .rrd"),
    ],
)
def test_bad_input_names_the_fault(change, part) -> None:
    with pytest.raises(s.InputError, match=None) as caught:
        change()
    assert part in str(caught.value)
    assert isinstance(caught.value, ValueError)
