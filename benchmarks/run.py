"""All benchmarks; `benchmarks/README.md` keeps what they printed on a named machine."""

from benchmarks import fem, growth, rigid, static_fields, stress

if __name__ == "__main__":
    growth.main()
    rigid.main()
    fem.main()
    static_fields.main()
    stress.main()
