#!/usr/bin/env -S python3 -B
input()
print("hello to you too")
