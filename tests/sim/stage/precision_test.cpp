// The production build beside the build with double state.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

namespace {

std::vector<double> figures(const std::string& program) {
    FILE* pipe = popen(("'" THIXO_BIN_DIR "/" + program + "'").c_str(), "r");
    std::string text;
    char buffer[256];
    while (pipe && std::fgets(buffer, sizeof buffer, pipe)) text += buffer;
    if (pipe) pclose(pipe);
    std::istringstream in(text);
    std::vector<double> values;
    for (double v; in >> v;) values.push_back(v);
    return values;
}

TEST(Precision, FloatAndDoubleRunsAgree) {
    const auto single = figures("short_run"), twice = figures("short_run_double");
    ASSERT_EQ(single.size(), 6u);
    ASSERT_EQ(twice.size(), 6u);
    EXPECT_EQ(single[0], twice[0]);
    EXPECT_NEAR(single[1], twice[1], 1e-5 * twice[1]);
    // Single paths differ, because a splash is chaotic. The centre of mass agrees to a hundredth of a spacing.
    for (int a = 2; a < 5; ++a) EXPECT_NEAR(single[a], twice[a], 1e-4);
    // Kinetic energy of the whole: mostly the fall of the drop, 1 %.
    EXPECT_NEAR(single[5], twice[5], 0.01 * twice[5]);
}

}  // namespace
