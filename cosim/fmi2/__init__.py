"""FMUs as files and as libraries: descriptions, archives, and the calls of FMI 2.0."""
