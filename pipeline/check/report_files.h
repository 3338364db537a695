// A check's report as files: for a server that runs tests, and for a person who looks at pictures.
#pragma once

#include <string>

#include "pipeline/check/report.h"

namespace thixo {

/// JUnit's XML: a test suite named after the reference, with a test case for each frame. A frame that differs is a
/// failure, a damaged one an error.
std::string print_junit(const CheckReport& report);

/// A page with the numbers of all frames, and the difference pictures that lie beside it. It loads nothing from
/// elsewhere and runs no script.
std::string print_html(const CheckReport& report);

}  // namespace thixo
