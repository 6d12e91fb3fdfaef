# Hash of the sources that turn samples into rows: rows in a store are measured again when it changes.
# Called with -DOUT=header -DLIST=file that names the sources, one a line.
file(STRINGS ${LIST} sources)
set(hashes "")
foreach(source ${sources})
  file(SHA256 ${source} hash)
  string(APPEND hashes ${hash})
endforeach()
string(SHA256 version "${hashes}")
string(SUBSTRING ${version} 0 32 version)
file(WRITE ${OUT} "// Generated: hash of the sources that turn samples into rows.
#pragma once
namespace atwood {
inline constexpr const char* kMetricsVersion = \"${version}\";
}
")
