//! Built-in scenes, drawn by code, equal on every machine. For the browser they are WebAssembly, without `std`.

#![cfg_attr(target_family = "wasm", no_std)]

pub mod border;
pub mod noise;
pub mod periodic;
pub mod random;
mod rays;
pub mod slow;
mod sqrt;
pub mod street;
pub mod synthetic;
mod texture;
pub mod tiles;
#[cfg(target_family = "wasm")]
#[allow(unsafe_code)] // the boundary to JavaScript
mod web;

/// Units per pixel: positions are in sixteenths of a pixel.
const PIXEL: i32 = 16;

/// A box: left, top, width and height in pixels.
pub type Sides = [i32; 4];
