//! Numerical settings for a required accuracy of the settled motion: one rule for every scene.

use super::error::SceneError;
use super::spec::Scene;

/// Numbers of contact nodes of the Gauss rules, ascending. The last one is the reference of the others.
pub const GAUSS_NODES: [usize; 6] = [16, 36, 64, 100, 300, 1000];

/// Maximum step, s, at which the tolerance and not the maximum decides about the steps of a joint.
pub const FREE_STEP: f64 = 1e-4;

impl Scene {
    /// Returns the scene with the tolerance and the number of contact nodes for a relative error of frequency, amplitude
    /// and rms velocity of its settled motion. Imported contact nodes stay as they are; a small system has none.
    ///
    /// The rule was read off from the shipped joints, each compared with a tolerance of 1e-8 and 300 nodes. With tolerances
    /// of 1e-3, 1e-4 and 1e-5 the largest error of the integrator was 6e-3, 2e-4 and 3e-5, so that the tolerance is a
    /// tenth of the error. With 16 nodes the largest error of the patch was 6e-4 (`contact-age`, whose friction remembers, and
    /// `lift-off`, where nodes separate), with 64 nodes 9e-5. An ignored test, and `squeakscope cost`, compare the settings
    /// with the next finer level of everything.
    ///
    /// # Errors
    /// If the integration method of the scene has no tolerance.
    pub fn with_accuracy(&self, error: f64) -> Result<Self, SceneError> {
        let method = self.integrator.method;
        if method.has_fixed_step() {
            let problem = format!(
                "`{}` has a fixed step and no tolerance that an accuracy could determine",
                method.name()
            );
            let remedy = "choose another time.method, such as \"lawson54\"";
            return Err(SceneError::new("--accuracy".to_owned(), problem, remedy));
        }
        let nodes = match error {
            1e-3.. => 16,
            1e-4.. => 64,
            _ => 300,
        };
        self.with_numerics((0.1 * error).clamp(1e-13, 1e-3), Some(nodes))
    }

    /// Returns the scene with a tolerance that alone decides about the steps and, if it has a ball on a beam, with a Gauss
    /// rule of contact nodes.
    pub(crate) fn with_numerics(
        &self,
        tolerance: f64,
        nodes: Option<usize>,
    ) -> Result<Self, SceneError> {
        // Rounding to 1 ps keeps the decimal short in the text.
        let step_us = (1e9 * self.integrator.max_step.max(FREE_STEP)).round() / 1e3;
        let mut settings = vec![
            ("time.tolerance", format!("{tolerance:e}")),
            ("time.max_step_us", step_us.to_string()),
        ];
        if let Some(nodes) = nodes.filter(|_| self.ball_on_beam().is_ok()) {
            settings.push(("contact.quadrature", "gauss".to_owned()));
            settings.push(("contact.nodes", nodes.to_string()));
        }
        self.with_overrides(&settings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smaller_error_never_has_looser_settings() {
        let scene = Scene::load("doubled-torus-3deg").unwrap();
        let settings = (0..60).map(|k| {
            let scene = scene
                .with_accuracy(10f64.powf(-0.1 * f64::from(k)))
                .unwrap();
            let nodes = scene.joint().unwrap().spec.contact.nodes;
            (scene.integrator.tolerance, nodes)
        });
        let all: Vec<_> = settings.collect();
        for pair in all.windows(2) {
            assert!(pair[1].0 <= pair[0].0 && pair[1].1 >= pair[0].1);
        }
        assert!(all.iter().all(|(_, nodes)| GAUSS_NODES.contains(nodes)));
    }

    #[test]
    fn the_settings_are_in_the_scene_and_in_its_text() {
        let scene = Scene::load("doubled-torus-3deg")
            .unwrap()
            .with_accuracy(1e-4)
            .unwrap();
        let again = Scene::parse("again.toml", scene.text.clone()).unwrap();
        for scene in [scene, again] {
            assert_eq!(scene.integrator.tolerance, 1e-5);
            assert_eq!(scene.joint().unwrap().spec.contact.nodes, 64);
        }
        // A small system has a tolerance only.
        let small = Scene::load("mass-on-belt")
            .unwrap()
            .with_accuracy(1e-4)
            .unwrap();
        assert_eq!(small.integrator.tolerance, 1e-5);
    }

    #[test]
    fn a_fixed_step_is_refused() {
        let set = [
            ("time.method", "rk4"),
            ("time.max_step_us", "1"),
            ("time.tolerance", "absent"),
        ];
        let scene = Scene::load("doubled-torus-3deg")
            .unwrap()
            .with_overrides(&set)
            .unwrap();
        let refused = scene.with_accuracy(1e-4).unwrap_err().to_string();
        assert!(refused.contains("time.method"), "{refused}");
    }
}
