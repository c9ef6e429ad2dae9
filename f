to lf
print 1
end
