//! The physics of the ball joint, Eq. (1) to (8).

mod spec;

pub use spec::{
    BodySpec, Contact, Frequencies, Friction, JointSpec, Quadrature, Socket, StiffnessLaw,
};
