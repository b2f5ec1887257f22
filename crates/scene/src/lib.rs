//! What surrounds the water: floor, walls, materials, cameras.
