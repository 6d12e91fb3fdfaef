// Descriptors 0 to 2 of a program that was started without them.
#pragma once

namespace atwood {

// Opens /dev/null on each of 0, 1 and 2 that is closed, so that no other file gets this descriptor. To be called first
// in main. Reading from a closed 0 then gives end of file, output to a closed 2 is dropped, and writing to a closed 1
// fails with EBADF, so that lost results are an error.
void open_standard_descriptors();

// From now on output to `stderr` that descriptor 2 does not accept is dropped: a full or broken standard error does not
// end the program.
void forgive_standard_error();

}  // namespace atwood
