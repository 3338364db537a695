#include "sim/solid/rigid_pieces.h"

#include <Eigen/Geometry>

#include "sim/solid/rigid_fit.h"

namespace thixo {
namespace {

Vec3d place_of(const Elements& e, std::size_t i) {
    return xyz(e.rest[i]).cast<double>() + xyz(e.displacement[i]).cast<double>();
}
Vec3d velocity_of(const Elements& e, std::size_t i) { return xyz(e.velocity[i]).cast<double>(); }

}  // namespace

RigidPieces::RigidPieces(const Solids& solids) {
    const Elements& e = solids.elements;
    for (std::size_t b = 0; b < solids.bodies.size(); ++b) {
        const SolidBody& body = solids.bodies[b];
        if (!body.rigid || body.empty()) continue;
        Piece piece{.body = b};
        piece.rates = rigid_rates(body, e, [&](std::size_t k) {
            const std::size_t i = body.elements[k];
            return std::pair(place_of(e, i), Vec3d(static_cast<double>(e.mass[i]) * velocity_of(e, i)));
        });
        piece.start = piece.centre = piece.rates.centre;
        for (const Index i : body.elements) {
            piece.shape.push_back(place_of(e, i) - piece.centre);
            piece.displacement.push_back(e.displacement[i]);
        }
        pieces_.push_back(std::move(piece));
    }
}

void RigidPieces::set_motion(const Piece& piece, double kick, Solids& solids) const {
    Elements& e = solids.elements;
    const std::vector<Index>& elements = solids.bodies[piece.body].elements;
    const Vec3d spin = piece.turn * piece.rates.spin;
    for (std::size_t k = 0; k < elements.size(); ++k) {
        const Index i = elements[k];
        const Vec3d v = piece.rates.velocity + spin.cross(piece.turn * piece.shape[k]);
        if (kick > 0) e.acceleration[i] += ((v - velocity_of(e, i)) / kick).cast<Real>();
        e.velocity[i] = quad(v.cast<Real>());
        e.displacement[i] = quad((piece.place(k) - xyz(e.rest[i]).cast<double>()).cast<Real>());
    }
}

void RigidPieces::follow(double drift, double kick, Solids& solids) {
    const Elements& e = solids.elements;
    for (Piece& piece : pieces_) {
        const std::vector<Index>& elements = solids.bodies[piece.body].elements;
        Vec3d momentum(0, 0, 0), angular(0, 0, 0), moved(0, 0, 0);
        for (std::size_t k = 0; k < elements.size(); ++k) {
            const Index i = elements[k];
            const double mass = static_cast<double>(e.mass[i]);
            const Vec3d v = velocity_of(e, i);
            momentum += mass * v;
            angular += mass * (piece.turn * piece.shape[k]).cross(v);
            moved += mass * (place_of(e, i) - piece.place(k) - drift * v);
        }
        RigidRates& rates = piece.rates;
        rates.velocity = momentum / rates.mass;
        rates.spin = rates.spin_of(piece.turn.transpose() * angular);
        const Turning on = turn_on(rates, drift);
        piece.turn = Quatd(Mat3d(piece.turn * on.turn)).normalized().toRotationMatrix();
        rates.spin = on.spin;
        piece.centre += drift * rates.velocity;
        // Samples meet walls as springs. Elements are moved out of them.
        if (!solids.contacts.by_samples[piece.body]) piece.centre += moved / rates.mass;
        set_motion(piece, kick, solids);
    }
}

void RigidPieces::fit(Solids& solids) {
    const Elements& e = solids.elements;
    for (Piece& piece : pieces_) {
        const SolidBody& body = solids.bodies[piece.body];
        const RigidRates now = rigid_rates(body, e, [&](std::size_t k) {
            const std::size_t i = body.elements[k];
            return std::pair(place_of(e, i), Vec3d(static_cast<double>(e.mass[i]) * velocity_of(e, i)));
        });
        Mat3d spread = Mat3d::Zero();
        for (std::size_t k = 0; k < body.size(); ++k) {
            const Index i = body.elements[k];
            spread += static_cast<double>(e.mass[i]) * piece.shape[k] * (place_of(e, i) - now.centre).transpose();
        }
        piece.centre = now.centre;
        piece.turn = fitting_rotation(spread);
        piece.rates.velocity = now.velocity;
        piece.rates.spin = piece.rates.spin_of(piece.turn.transpose() * now.angular);
        set_motion(piece, 0, solids);
    }
}

void RigidPieces::end(Solids& solids) const {
    Elements& e = solids.elements;
    for (const Piece& piece : pieces_) {
        SolidBody& body = solids.bodies[piece.body];
        const Mat3d back = piece.turn.transpose();
        for (std::size_t k = 0; k < body.size(); ++k) {
            const Index i = body.elements[k];
            e.displacement[i] = piece.displacement[k];
            e.velocity[i] = quad((back * velocity_of(e, i)).cast<Real>());
            e.acceleration[i] = (back * e.acceleration[i].cast<double>()).cast<Real>();
        }
        body.place += body.turn * (piece.centre - piece.turn * piece.start);
        body.turn = Quatd(Mat3d(body.turn * piece.turn)).normalized().toRotationMatrix();
    }
}

}  // namespace thixo
