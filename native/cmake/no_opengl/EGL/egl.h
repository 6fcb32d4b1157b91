#error "OpenGL belongs to native/src/engine/opengl: include engine/engine.h, and let an engine do it."
