"""Machines from datasheets, and case files, which may hold a datasheet."""

from exudyn_crawler.machines.case_file import CaseFile, Outputs, check_case_file, differences
from exudyn_crawler.machines.case_files import case_of, read_case, saved_case, write_case
from exudyn_crawler.machines.datasheet.derive import derived
from exudyn_crawler.machines.datasheet.sheet import Datasheet
