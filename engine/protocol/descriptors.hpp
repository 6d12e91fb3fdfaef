// Descriptors 0 to 2 of a program that was started without them.
#pragma once

namespace atwood {

// Opens /dev/null on each of 0, 1 and 2 that is closed, so that no file, pipe or store ever takes its place. First
// thing in main. What is read from a closed 0 is at its end, what is written to a closed 2 is dropped; writing to a
// closed 1 fails with EBADF, so that results are never lost in silence.
void open_standard_descriptors();

// From now on what is printed to `stderr` goes to descriptor 2 as far as that takes it, and is dropped otherwise: a full
// or broken standard error ends nothing.
void forgive_standard_error();

}  // namespace atwood
