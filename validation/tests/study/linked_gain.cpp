extern "C" double linked_gain() { return 1; }
