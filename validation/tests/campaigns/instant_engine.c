/* An engine that answers at once, whatever it is asked: for measurements of everything around engines. One body, at
 * most 64 samples; the settings a and b tell its methods apart. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static long number_after(const char* line, const char* key) {
  const char* at = strstr(line, key);
  return at ? atol(at + strlen(key)) : 0;
}

int main(void) {
  static char line[1 << 20];
  setvbuf(stdout, NULL, _IOFBF, 1 << 16);
  while (fgets(line, sizeof line, stdin)) {
    if (strstr(line, "\"request\":\"hello\"")) {
      printf("{\"engine\":\"instant\",\"version\":\"1\",\"scalar\":\"double\",\"fingerprint\":\"1\",\"methods\":[{\"id\":\"instant/one\","
             "\"doc\":\"one\",\"settings\":{\"a\":0,\"b\":0}}]}\n");
    } else {
      const long cell = number_after(line, "\"cell\":"), samples = number_after(line, "\"samples\":"),
                 steps = number_after(line, "\"steps\":"), a = number_after(line, "\"a\":"), b = number_after(line, "\"b\":");
      const char* end = strstr(line, "\"t_end_s\":");
      const double t_end = end ? atof(end + 10) : 1;
      for (long k = 0; k <= samples; ++k) {
        const double t = t_end * (double)k / (double)samples, error = 1e-3 * t / (double)(steps * steps) * (double)(1 + a % 7 + b % 5);
        printf("{\"cell\":%ld,\"t_s\":%.17g,\"bodies\":[[%.17g,0,0,1,0,0,0,1,0,0,0,0,0]]}\n", cell, t, t + error);
      }
      printf("{\"cell\":%ld,\"done\":{\"status\":\"ok\",\"reason\":\"\",\"steps_taken\":%ld,\"rate_evaluations\":%ld}}\n", cell, steps,
             steps);
    }
    fflush(stdout);
  }
  return 0;
}
