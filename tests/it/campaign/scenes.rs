//! Random scenes as TOML text.

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

/// A positive number, log-uniform in a range, or one of its ends.
pub fn positive(low: f64, high: f64) -> BoxedStrategy<String> {
    let inside = (low.ln()..=high.ln()).prop_map(move |x| x.exp().clamp(low, high));
    prop_oneof![1 => Just(low), 1 => Just(high), 10 => inside]
        .prop_map(|x| format!("{x:?}"))
        .boxed()
}

/// A number in a range, or one of its ends or its middle.
pub fn number(low: f64, high: f64) -> BoxedStrategy<String> {
    prop_oneof![1 => Just(low), 1 => Just(high), 1 => Just(0.5 * (low + high)), 10 => low..=high]
        .prop_map(|x| format!("{x:?}"))
        .boxed()
}

/// An integer in a range, log-uniform, so that small ones are more frequent.
pub fn count(low: u32, high: u32) -> BoxedStrategy<String> {
    let inside = (f64::from(low.max(1)).ln()..=f64::from(high).ln()).prop_map(|x| x.exp() as u32);
    prop_oneof![1 => Just(low), 10 => inside]
        .prop_map(move |n| n.clamp(low, high).to_string())
        .boxed()
}

pub fn word(words: &'static [&'static str]) -> BoxedStrategy<String> {
    select(words).prop_map(|word| format!("\"{word}\"")).boxed()
}

pub fn flag() -> BoxedStrategy<String> {
    any::<bool>().prop_map(|flag| flag.to_string()).boxed()
}

pub fn vector(component: BoxedStrategy<String>) -> BoxedStrategy<String> {
    let zero = Just("0".to_owned());
    vec(prop_oneof![1 => zero, 3 => component], 3)
        .prop_map(|c| format!("[{}]", c.join(", ")))
        .boxed()
}

/// Keys of a joint scene and their values, over the ranges of `squeakscope scenes --keys`; numbers of nodes
/// and elements are smaller, because only their run time grows.
pub fn keys() -> Vec<(&'static str, BoxedStrategy<String>)> {
    vec![
        ("body.beam_length_to", word(&["sphere", "centre"])),
        ("body.youngs_modulus_gpa", positive(0.001, 2000.0)),
        ("body.poissons_ratio", number(-0.99, 0.49)),
        ("body.density_kg_m3", positive(10.0, 30_000.0)),
        ("body.element_order", count(1, 6)),
        ("socket.youngs_modulus_gpa", positive(0.001, 2000.0)),
        ("socket.poissons_ratio", number(-0.99, 0.49)),
        ("load.azimuth_deg", number(-360.0, 360.0)),
        (
            "rotation.angular_velocity_rad_per_s",
            vector(number(-1e4, 1e4)),
        ),
        ("rotation.convection", flag()),
        ("contact.nodes", count(1, 200)),
        ("contact.quadrature", word(&["rings", "gauss"])),
        ("contact.stiffness_factor", positive(1e-6, 1e4)),
        (
            "contact.stiffness_distribution",
            word(&["uniform", "pre-stress"]),
        ),
        ("contact.radius_factor", positive(0.1, 5.0)),
        ("contact.unilateral", flag()),
        ("friction.creep_slope_s_per_m", positive(1e-3, 1e8)),
        ("friction.radial", flag()),
        ("damping.ratio", number(0.0, 0.999)),
        ("start.kick_mm_per_s", positive(1e-320, 1000.0)),
        ("start.seed", count(0, 1_000_000)),
        ("time.sample_rate_khz", positive(100.0, 2000.0)),
        (
            "time.method",
            word(&[
                "lawson54",
                "lawson853",
                "tsit5",
                "dop853",
                "rodas5p",
                "auto",
                "rk4",
            ]),
        ),
        ("time.tolerance", positive(1e-13, 1e-2)),
        ("time.max_step_us", positive(0.001, 1000.0)),
        ("time.events", word(&["through", "exact"])),
    ]
}

/// Dimensions that are usually consistent: ball, beam inside it, socket around it.
pub fn dimensions() -> BoxedStrategy<String> {
    (0.0..6.2_f64, 0.01..1.02_f64, 0.0..8.5_f64, -7.0..0.7_f64)
        .prop_map(|(ball, beam, length, gap)| {
            let ball = ball.exp();
            format!(
                "body.ball_diameter_mm = {ball:?}\nbody.beam_diameter_mm = {:?}\n\
                 body.beam_length_mm = {:?}\nbody.element_size_mm = {:?}\nsocket.diameter_mm = {:?}\n",
                (beam * ball).max(0.5),
                length.exp(),
                ball.max(length.exp() / 40.0).clamp(0.1, 100.0),
                ball * (1.0 + gap.exp())
            )
        })
        .boxed()
}

/// The paper's modes, fewer modes, or others.
pub fn modes() -> BoxedStrategy<String> {
    let of = |pairs, torsion, axial, words| {
        (count(0, pairs), count(0, torsion), count(0, axial), word(words))
            .prop_map(|(pairs, torsion, axial, frequencies)| {
                format!(
                    "body.bending_pairs = {pairs}\nbody.torsion_modes = {torsion}\nbody.axial_modes = {axial}\n\
                     body.frequencies = {frequencies}\n"
                )
            })
            .boxed()
    };
    prop_oneof![of(4, 2, 1, &["published", "fe"]), of(8, 4, 3, &["fe"])].boxed()
}

/// A friction law with its coefficients, with or without a slope.
pub fn friction() -> BoxedStrategy<String> {
    let mu = || number(0.0, 10.0);
    let slope = prop_oneof![
        2 => Just(String::new()),
        1 => positive(1e-3, 1e6).prop_map(|f| format!("friction.stribeck_slope_s_per_m = {f}\n")),
    ];
    let falling = (mu(), mu(), slope).prop_map(|(mu_s, mu_d, slope)| {
        format!("friction.mu_s = {mu_s}\nfriction.mu_d = {mu_d}\n{slope}")
    });
    let level = mu().prop_map(|mu| format!("friction.law = \"constant\"\nfriction.mu = {mu}\n"));
    let measured = vec((1e-6..10.0, 0.0..10.0), 1..6).prop_map(|steps| {
        let points = steps.iter().scan(0.0, |speed, (step, mu)| {
            *speed += step;
            Some(format!("{{ speed_m_per_s = {speed:?}, mu = {mu:?} }}"))
        });
        let points: Vec<String> = points.collect();
        format!(
            "friction.law = \"table\"\nfriction.points = [{}]\n",
            points.join(", ")
        )
    });
    prop_oneof![3 => falling, 1 => level, 1 => measured, 1 => bristles(), 1 => contact_age()]
        .boxed()
}

/// LuGre friction.
fn bristles() -> BoxedStrategy<String> {
    let optional = |key: &'static str, most| {
        let line = positive(1e-6, most).prop_map(move |x| format!("friction.{key} = {x}\n"));
        prop_oneof![1 => Just(String::new()), 1 => line]
    };
    (
        [positive(1e-3, 10.0), positive(1e-3, 10.0)],
        positive(1e2, 1e9),
        optional("bristle_damping_s_per_m", 1e4),
        optional("viscous_s_per_m", 1e4),
        optional("stribeck_slope_s_per_m", 1e6),
    )
        .prop_map(|([mu_s, mu_d], stiffness, damping, viscous, slope)| {
            format!(
                "friction.law = \"lugre\"\nfriction.mu_s = {mu_s}\nfriction.mu_d = {mu_d}\n\
                 friction.bristle_stiffness_per_m = {stiffness}\n{damping}{viscous}{slope}"
            )
        })
        .boxed()
}

/// Rate-and-state friction, mostly with a direct effect that is large enough for its coefficient.
fn contact_age() -> BoxedStrategy<String> {
    (
        positive(1e-2, 3.0),
        positive(1e-2, 1.0),
        number(0.0, 1.0),
        positive(1e-9, 1e3),
        positive(1e-3, 1e5),
    )
        .prop_map(|(mu, direct, evolution, speed, distance)| {
            format!(
                "friction.law = \"rate-and-state\"\nfriction.mu_0 = {mu}\n\
                 friction.direct_effect = {direct}\nfriction.evolution_effect = {evolution}\n\
                 friction.reference_speed_m_per_s = {speed}\nfriction.slip_distance_um = {distance}\n"
            )
        })
        .boxed()
}

/// Load and tilt, constant or changing within the run, and a rotation that changes or moves the patch.
fn loading() -> BoxedStrategy<String> {
    let load = || positive(1e-6, 1e6);
    let tilt = || number(-90.0, 90.0);
    let constant = (load(), tilt())
        .prop_map(|(load, tilt)| format!("load.load_n = {load}\nload.tilt_deg = {tilt}\n"));
    let stepped = (load(), positive(0.3, 3.0), tilt()).prop_map(|(load, ratio, tilt)| {
        format!(
            "load.load_steps = [{{ time_ms = 0, load_n = {load} }}, \
             {{ time_ms = 0.4, load_n = {:?} }}]\nload.tilt_deg = {tilt}\n",
            (number_of(&load) * number_of(&ratio)).clamp(1e-6, 1e6)
        )
    });
    let tilted = (load(), number(-60.0, 60.0), number(-5.0, 5.0)).prop_map(|(load, tilt, step)| {
        format!(
            "load.load_n = {load}\nload.tilt = [{{ time_ms = 0, tilt_deg = {tilt} }}, \
             {{ time_ms = 0.8, tilt_deg = {:?} }}]\n",
            number_of(&tilt) + number_of(&step)
        )
    });
    let turning = (load(), number(-30.0, 30.0), any::<bool>()).prop_map(|(load, tilt, reverses)| {
        let factor = match reverses {
            true => "rotation.factor_sine = { mean = 0, amplitude = 3, frequency_hz = 700 }\n",
            false => "",
        };
        format!("load.load_n = {load}\nload.tilt_deg = {tilt}\nrotation.moves_patch = true\n{factor}")
    });
    let carry = prop_oneof![
        1 => Just(String::new()),
        1 => Just("time.carry = \"displacement\"\n".to_owned()),
    ];
    let loading = prop_oneof![4 => constant, 1 => stepped, 1 => tilted, 1 => turning];
    (loading, carry)
        .prop_map(|(loading, carry)| loading + &carry)
        .boxed()
}

/// The number of a text of [`number`] or [`positive`].
fn number_of(text: &str) -> f64 {
    text.parse().expect("a number")
}

/// Contact damping of either law.
pub fn contact_damping() -> BoxedStrategy<String> {
    let law = |law: &'static str, key: &'static str, most| {
        positive(1e-6, most).prop_map(move |x| {
            format!("contact_damping.law = \"{law}\"\ncontact_damping.{key} = {x}\n")
        })
    };
    prop_oneof![
        law("kelvin-voigt", "retardation_time_us", 1e4),
        law("hunt-crossley", "dissipation_s_per_m", 100.0),
    ]
    .boxed()
}

/// A small change of the defaults: two of three optional keys are omitted, so that the scene stays
/// consistent.
pub fn joint_scene() -> BoxedStrategy<String> {
    let optional = keys().into_iter().map(|(key, value)| {
        let line = value.prop_map(move |value| format!("{key} = {value}\n"));
        prop_oneof![2 => Just(String::new()), 1 => line].boxed()
    });
    let blocks = [dimensions(), modes(), contact_damping()];
    let blocks = blocks.map(|block| prop_oneof![2 => Just(String::new()), 1 => block].boxed());
    let lines: Vec<_> = optional
        .chain(blocks)
        .chain([loading(), friction()])
        .collect();
    lines
        .prop_map(|mut lines| {
            // These laws do not use the creep slope.
            let law = lines.last().cloned().unwrap_or_default();
            if ["lugre", "rate-and-state"]
                .iter()
                .any(|name| law.contains(name))
            {
                lines.retain(|line| !line.starts_with("friction.creep_slope"));
            }
            format!(
                "{}time.duration_ms = 1.0\ntime.frame_samples = 2\nrecord.energy_rate_khz = 100\n",
                lines.concat()
            )
        })
        .boxed()
}

/// A scene of a small system.
pub fn small_scene() -> BoxedStrategy<String> {
    let table = |name: &'static str, keys: Vec<(&'static str, BoxedStrategy<String>)>| {
        let lines: Vec<_> = keys
            .into_iter()
            .map(move |(key, value)| {
                value
                    .prop_map(move |v| format!("{name}.{key} = {v}\n"))
                    .boxed()
            })
            .collect();
        lines.prop_map(|lines| lines.concat()).boxed()
    };
    let drive = || {
        [
            ("damping_ratio", number(0.0, 0.99)),
            (
                "drive_amplitude_m_per_s2",
                prop_oneof![Just("0".to_owned()), positive(1e-6, 1e6)].boxed(),
            ),
            (
                "drive_frequency_hz",
                prop_oneof![Just("0".to_owned()), positive(1e-3, 1e5)].boxed(),
            ),
        ]
    };
    let mut impact = vec![
        ("natural_frequency_hz", positive(1e-3, 1e5)),
        ("wall_position_um", number(-1e6, 1e6)),
        ("restitution", number(0.0, 1.0)),
    ];
    impact.extend(drive());
    let mut damped = vec![
        ("natural_frequency_hz", positive(1e-3, 1e5)),
        ("contact_frequency_hz", positive(1e-3, 1e5)),
        ("contact_damping_ratio", number(0.0, 0.99)),
    ];
    damped.extend(drive());
    let belt = vec![
        ("natural_frequency_hz", positive(1e-3, 1e5)),
        ("damping_ratio", number(0.0, 0.99)),
        ("load_n_per_kg", positive(1e-6, 1e6)),
        ("mu_s", number(0.0, 10.0)),
        ("mu_d", number(0.0, 10.0)),
        ("belt_speed_mm_per_s", positive(1e-6, 1e5)),
    ];
    let system = prop_oneof![
        table("impact_oscillator", impact),
        table("damped_contact", damped),
        table("mass_on_belt", belt)
    ];
    let methods = word(&[
        "lawson54",
        "lawson853",
        "tsit5",
        "dop853",
        "rodas5p",
        "auto",
    ]);
    (
        system,
        methods,
        number(-1e6, 1e6),
        number(-1e5, 1e5),
        positive(1e-13, 1e-2),
    )
        .prop_map(|(system, method, position, velocity, tolerance)| {
            format!(
                "{system}start.position_um = {position}\nstart.velocity_mm_per_s = {velocity}\n\
                 time.method = {method}\ntime.tolerance = {tolerance}\ntime.duration_ms = 20\n\
                 time.sample_rate_khz = 20\ntime.frame_samples = 2\n"
            )
        })
        .boxed()
}
