// Whether two means that are known only up to noise differ (B. L. Welch, Biometrika 34, 1947).
#pragma once

namespace thixo {

/// Probability of |t| or more under Student's distribution with `freedom` > 0 degrees of freedom.
double student_tail(double t, double freedom);

/// The difference of two sums of independent values. Each value is a mean of n samples, and its variance is estimated
/// from these with n - 1 degrees of freedom.
struct WelchSum {
    double difference = 0;  // sum of (a - b)
    double variance = 0;    // of the difference
    double squares = 0;     // sum of variance^2/degrees of freedom

    /// One value of one side: its variance by estimate, and a variance that is known, as that of rounding.
    void add_variance(double estimated, double freedom, double known);
    /// How probable a difference of this size is where there is none but noise. Without any noise: 1 or 0.
    double probability() const;
};

}  // namespace thixo
