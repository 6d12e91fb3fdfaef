// Empty. CMake writes a target's precompiled header only when one of its sources uses it, and main.cpp must not.
