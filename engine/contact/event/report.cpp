#include "contact/event/report.hpp"

namespace atwood::event {

namespace {

bool end_at(Report& report, Status status, double t_s, const std::string& what) {
  report.outcome = {status, "atwood's +event: at t = " + format_double(t_s) + " s " + what, 0, 0, {}};
  return false;
}

}  // namespace

bool end_run(Report& report, Status status, const std::string& reason) {
  report.outcome = {status, reason, 0, 0, {}};
  return false;
}

bool refuse_at(Report& report, double t_s, const std::string& what) {
  return end_at(report, Status::unsupported, t_s, what);
}

bool diverged_at(Report& report, double t_s, const std::string& what) {
  return end_at(report, Status::diverged, t_s, what);
}

}  // namespace atwood::event
