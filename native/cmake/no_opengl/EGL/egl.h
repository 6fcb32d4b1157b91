#error "OpenGL belongs to native/src/engine/paper: include engine/engine.h, and let an engine do it."
