#include "pipeline/driver/json_output.h"

#include <cstdio>
#include <nlohmann/json.hpp>

namespace thixo {

void print_json(const nlohmann::ordered_json& value) {
    using Errors = nlohmann::ordered_json::error_handler_t;
    std::puts(value.dump(-1, ' ', false, Errors::replace).c_str());
}

}  // namespace thixo
