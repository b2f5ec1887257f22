//! End-to-end cases, expected images and the image-comparison kit.
