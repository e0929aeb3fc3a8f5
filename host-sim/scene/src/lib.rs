//! Built-in scenes, drawn by code alone and alike on every machine. The browser's page has them as WebAssembly, which is without `std`.

#![cfg_attr(target_family = "wasm", no_std)]

pub mod random;
mod rays;
pub mod street;
pub mod synthetic;
pub mod texture;
pub mod tiles;
#[cfg(target_family = "wasm")]
#[allow(unsafe_code)] // the boundary to JavaScript
mod web;

/// Units in a pixel: positions are counted in sixteenths of a pixel.
pub const PIXEL: i32 = 16;

/// Left, top, width and height in pixels.
pub type Sides = [i32; 4];
