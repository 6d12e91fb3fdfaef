#include "mujoco/mujoco.hpp"
#include "protocol/worker.hpp"

int main() { return atwood::serve(atwood::mujoco_engine()); }
