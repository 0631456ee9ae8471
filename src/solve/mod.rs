//! The ways to solve the discrete problem, all behind one trait.
