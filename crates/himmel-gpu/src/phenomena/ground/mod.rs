//! The planet's surface: a sphere that reflects evenly (Lambert), lit by the Sun through the air and by the sky.
//!
//! - **What it costs**: one read of the optical depth and one of the irradiance table a pixel.
//! - **What it leaves out**: relief, textures, water; light that went from ground to sky to ground.
//! - **Known to look wrong**: close to the camera it is one colour, as no ground is. Hosts draw their own over it.
