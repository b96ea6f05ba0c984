#pragma once
#include "sinew/bus/predict.hpp"

#include <string>

/// The serial line between this machine and an SLCAN adapter, which carries every frame as text.
namespace sinew::cli {

struct AdapterPort {
    bool is_slcan = false;
    std::uint32_t baud =
        0; ///< that the link says; 0: none, so that the adapter is taken for one that is USB all the way
};

AdapterPort adapter_port_of(const std::string& link);

/// The time in which the line carries all requests and their answers, which go both ways at once. 0 where there is no
/// such line.
Duration time_on_port(const AdapterPort& port, std::span<const wire::Request> requests);

/// A bound on a stop that holds with this line: the text of what is outstanding, one request of each identifier, and of
/// its answers comes before that of the stop.
bus::StopBound on_port(const AdapterPort& port, bus::StopBound bound, std::span<const wire::Request> running,
                       std::span<const wire::Request> stop);

} // namespace sinew::cli
