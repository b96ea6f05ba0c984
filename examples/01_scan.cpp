#include "sinew/diagnosis/scanner.hpp"
#include "sinew/sim/links.hpp"
#include <cstdio>

using namespace sinew;

// Who is on this wire?
int main(int argc, char** argv)
{
    const char* const uri = argc > 1 ? argv[1] : "sim:robots/demo.toml#left"; // or "serial:/dev/ttyUSB0?baud=1500000"
    sim::Worlds worlds;
    link::RealClock clock;
    link::Links links = link::Links::system();
    sim::add(links, worlds);
    auto opened = sim::open(links, clock, uri, worlds);
    if (!opened)
        return std::puts(to_sentence(opened.error()).c_str()), 1;

    diagnosis::Line line(std::move(opened->link), *opened->clock);
    diagnosis::Scanner scanner(line);
    const auto places = diagnosis::passes({}, line.can(), line.bit_rate()); // the likely ones first
    std::vector<diagnosis::Found> found;
    const auto done = scanner.sweep(places, false, [] { return false; }, [](const auto&, int) {}, found);
    for (const auto& one : found)
        std::printf("%s %d at %u bps: %s\n", std::string(one.family->name).c_str(), one.id, one.bit_rate,
                    one.model.c_str());
    return done && found.size() == 6 ? 0 : 1; // the left arm has six servos
}
