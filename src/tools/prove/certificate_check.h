#pragma once

#include "tools/program/tool_main.h"
#include "tools/prove/certificate_file.h"
#include "tools/prove/proof_json.h"

#include <string>

namespace proximity_server::tools {

/// Verifies the certificate in a file, and prints what it states, or what is wrong. Returns AssertionFails if a pair
/// does not verify, and if there is none. Throws std::invalid_argument, naming the file and the place, if it cannot be read.
ExitCode checkCertificate(const std::string& path, const CertificateSubject& subject, ProofFormat format, int threads);

}  // namespace proximity_server::tools
