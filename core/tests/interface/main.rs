//! Tests of the public interface, in one program.

mod camera;
mod memory;
mod paper;
