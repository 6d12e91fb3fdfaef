#include "bullet/bullet.hpp"
#include "protocol/worker.hpp"

int main() { return atwood::serve(atwood::bullet_engine()); }
